"""Pages of HTML: one base template, and what all templates may use."""
