"""A scene at a glance: a contact sheet of pictures under several lights, and a top view."""
