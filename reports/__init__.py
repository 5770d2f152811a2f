"""How results are read: from a stored run alone to tables, figures and one HTML page."""
