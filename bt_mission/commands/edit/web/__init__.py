"""The page that edits missions: files, checks, acts, runs and proofs for a browser."""
