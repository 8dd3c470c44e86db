"""How joints tie links together: conditions, dependent coordinates and the frames of the links."""
