"""``python -m swarmvision`` is the command ``swarmvision``."""

from swarmvision.cli import main

main()
