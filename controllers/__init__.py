"""Estimates in, commands out: one law a module, pure."""

from swarmvision.controllers.law import Controller, Law, Memory, Sense, reflex
from swarmvision.controllers.registry import LAWS, controller

__all__ = ["LAWS", "Controller", "Law", "Memory", "Sense", "controller", "reflex"]
