"""What links are made of: properties of sections, strain and stress through their thickness."""
