"""Worker processes: cases computed in a process of their own, and what is said between it and this one."""
