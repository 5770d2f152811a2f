"""The stages of the dissertation's light filter, one function a file, equation by equation."""
