"""./tern study: what every knob costs and what it buys, measured (docs/TRADE.md)."""
