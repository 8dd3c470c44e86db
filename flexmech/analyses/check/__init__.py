"""What is known of a mechanism, and its natural frequencies at rest."""
