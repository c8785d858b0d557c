"""A model is a list of terms: predicted, fitted, and their uncertainty."""
