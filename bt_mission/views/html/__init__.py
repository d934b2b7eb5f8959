"""Pages of HTML: one base template, and the functions of all templates."""
