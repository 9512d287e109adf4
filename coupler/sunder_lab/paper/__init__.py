"""`sunder paper`: the figures and the table of the paper, run and drawn anew."""
