"""The commands of ``sightline``, a module each."""
