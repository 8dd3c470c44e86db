"""The path of a point of the coupler, dry and in heat and moisture."""
