"""The ``swarmvision`` command."""

from swarmvision.cli.commands import main

__all__ = ["main"]
