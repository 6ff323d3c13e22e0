"""PettingZoo environments around the simulation."""
