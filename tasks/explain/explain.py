"""The whole of `explain`: from a recording to the physics that the model left out."""
