"""What the terminal shows: progress while a command works, tables when it is done."""
