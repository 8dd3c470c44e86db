"""Whether links and pins fail under their loads: where, how, and by what factor these may rise."""
