"""What a scenario claims of its runs: paired by world, with the interval that its seeds leave open."""
