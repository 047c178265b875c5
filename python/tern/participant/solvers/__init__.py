"""Participants that come with tern, each a program: ./tern run CASE --structure "rigid_spring.py --stiffness 2e7"."""
