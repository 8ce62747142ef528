"""Compares what uvgraft reads with what independent readers do: `make test-peers FOLDER=...`."""
