"""Random convex contact problems of hard conditioning, solved by the program and proven by other methods.

Run `python3 python-checks/convex --scenes 300`.
"""
