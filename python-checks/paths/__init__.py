"""All solutions of random problems with one to three contact nodes, beside those that `branches --all` finds."""
