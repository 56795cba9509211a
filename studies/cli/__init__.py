"""The `contactstudy` command. May import everything else."""
