"""What people read of a result: the table on the terminal."""
