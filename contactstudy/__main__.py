"""``python -m contactstudy``: the command, which stands in the layer above."""

from studies.cli.main import main

if __name__ == "__main__":
    main()
