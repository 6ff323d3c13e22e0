"""What everything costs, against its rivals and in the same run: the work behind ``swarmvision bench``."""
