"""./tern study: what every parameter costs and what it buys, measured (docs/TRADE.md)."""
