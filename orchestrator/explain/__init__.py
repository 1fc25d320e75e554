"""What a system will do, before it does it: as data, as text and as a picture."""
