"""The commands of slipctl."""
