"""A model is a list of terms: prediction, fit and uncertainty."""
