"""Language models as a service: requests and replies, providers, prices, spending, kept replies."""
