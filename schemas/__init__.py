"""What is said: frozen models of everything that is stored, exchanged or printed."""
