"""Whether links break under their loads: where, how, and by what factor these may still rise."""
