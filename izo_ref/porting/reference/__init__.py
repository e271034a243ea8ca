"""Slow and obvious references of the stages in decimals, fractions and integers.

They use no numpy and no compiled code, so they are independent of the package that they judge, and
give the same digits with every version of Python. Start reading with `rounded.py`.
"""
