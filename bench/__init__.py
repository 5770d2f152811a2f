"""The experiment: studies, sequences, metrics, the runner, the result store, the command line."""
