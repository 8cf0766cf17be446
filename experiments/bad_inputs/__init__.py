"""Bad inputs through the commands: what each is answered, with which exit code, in how many seconds."""
