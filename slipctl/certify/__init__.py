"""The physics of a compiled robot against closed forms: fixtures, and the certificate they add up to."""
