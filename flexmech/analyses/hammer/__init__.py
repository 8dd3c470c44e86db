"""The virtual hammer test of the locked linkage: records, frequency responses, identified modes."""
