"""``python -m lpcompare.cli``: the command without its script."""

from lpcompare.cli import main

main()
