"""FMUs of any origin: their files read, their functions called."""
