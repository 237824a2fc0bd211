"""``python -m octray``: the program."""

from ._program import main

main()
