"""What a controller gets to see of the motion: estimates, noise and delay in place of the truth."""
