"""`sunder trade`: what each setting of a scene costs, and what error it leaves against a converged run."""
