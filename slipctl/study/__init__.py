"""Studies: several experiments, compared and explained.

`paper` reproduces Sections V and VI of Ryu & Agrawal; `rungs` compares real contacts, prescribed slip through
contacts and the paper's equations, and says where their gaps come from.
"""
