"""Requirements while a mission runs: signals sampled, formulas evaluated, verdicts with margins."""
