"""Estimates in, commands out: one law a module, pure."""

from swarmvision.controllers.registry import Controller, controller

__all__ = ["Controller", "controller"]
