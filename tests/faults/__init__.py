"""What goes wrong between the two processes, and how both have to end. `python3 -m tests.faults --table` prints it."""
