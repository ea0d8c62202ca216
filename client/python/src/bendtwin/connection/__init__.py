"""The way to a server: its address and TLS, the token shown to it, and the calls over both."""
