"""``python -m flexmech`` is ``flexmech``."""

from flexmech.cli import main

if __name__ == "__main__":
    main()
