"""Pages that answer: their server behind a door, and what is drawn, dragged and followed on them."""
