"""Learned policies: what they see, what they are, and what their actions mean."""
