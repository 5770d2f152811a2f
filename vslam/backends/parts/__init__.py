"""What several back-ends are made of."""
