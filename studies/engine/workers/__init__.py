"""Worker processes, which compute cases, and the messages between them and their supervisors."""
