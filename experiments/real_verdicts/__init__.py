"""What is said of real recordings whose missing physics their authors know."""
