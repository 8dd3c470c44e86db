"""How the rigid linkage moves, and which joint forces and torque that takes."""
