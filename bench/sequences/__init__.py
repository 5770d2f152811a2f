"""Where steps come from: the recorded DLR log and rendered tours, one module each."""
